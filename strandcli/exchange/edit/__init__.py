"""What `convert` changes, a file each. Each function returns the strands changed and a line that says by how much."""
