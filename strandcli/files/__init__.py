"""Files that a scene is read from: opened in one place, hashed, numbered by frames, decoded as pictures."""
