"""What a driver can practise: paths for the tip of any machine, how well they are followed, and results in a file."""
