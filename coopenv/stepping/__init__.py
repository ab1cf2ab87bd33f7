"""What happens in a step: all worlds go on together, and partners drive their agents."""
