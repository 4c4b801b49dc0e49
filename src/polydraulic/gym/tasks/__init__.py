"""What is to be done: `task` (what a task is), and one module for each."""
