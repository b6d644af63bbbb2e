"""Speed and accuracy of several position methods on one motion, with their true errors."""
