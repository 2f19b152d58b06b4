"""What is left on disk after a run: calibration.json, the frontier points as CSV, a picture of each pair."""
