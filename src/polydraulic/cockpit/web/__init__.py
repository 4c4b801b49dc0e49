"""What the browser talks to: who may, who drives, what is sent."""
