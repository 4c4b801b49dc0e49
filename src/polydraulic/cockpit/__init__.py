"""A machine driven by hand in a browser, on this computer alone: one thread that simulates, a page that shows it."""
