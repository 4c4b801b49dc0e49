"""What is wrong with a log, and what it can tell: times, values, coverage, deadbands, and the page that reports them."""
