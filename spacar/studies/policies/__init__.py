"""What is asked of many runs: an accuracy, the cheapest setting, a price, all values of a number."""
