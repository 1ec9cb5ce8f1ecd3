"""The loops of bounds, compiled."""
