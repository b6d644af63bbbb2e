"""Every way to assemble a mechanism at given inputs, with a certificate that none is missing."""
