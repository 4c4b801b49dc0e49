"""What a block of rows goes through, as kernels over plain arrays."""
