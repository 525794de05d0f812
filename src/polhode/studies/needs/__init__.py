"""What a need costs: the command for it, the digits it gives, its seconds."""
