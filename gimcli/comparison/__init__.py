"""Speed against accuracy: the methods of the field on one motion, and their true errors."""
