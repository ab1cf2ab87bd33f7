"""What trials are drawn from: environments with any features, actions, and wrenches with grips."""
