"""How fast this machine draws: measured once, kept in the user's cache folder, and refined by what runs report."""
