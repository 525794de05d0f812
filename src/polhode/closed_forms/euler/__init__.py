"""The torque-free body."""
