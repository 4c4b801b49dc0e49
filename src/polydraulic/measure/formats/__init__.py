"""What log files hold, block by block: `log` says what a log is, `logs` opens one of any format."""
