"""Files of our own, written whole or not at all: archives without pickle, JSON, CSV."""
