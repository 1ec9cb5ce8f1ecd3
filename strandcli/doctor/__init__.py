"""What `strandcli doctor` looks at: software, machine, kernel cache, and a picture that is known."""
