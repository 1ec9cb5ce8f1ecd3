"""Cameras of other programs: views as they are written to files and read from them (`read.views_of`)."""
