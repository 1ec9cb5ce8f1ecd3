"""What all rooms use: registries of drivers, numbers in words, and optional packages."""
