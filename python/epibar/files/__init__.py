"""Files of our own, written whole or not at all: npz archives without pickle, JSON, CSV."""
