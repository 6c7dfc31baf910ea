"""From what base and feet should do to joint torques."""
