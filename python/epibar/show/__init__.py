"""What is shown of a pair, and in which colours: plots, the report and the live view have it in common."""
