"""Presets that `strandcli new` writes: commented, and drawn as they are."""
