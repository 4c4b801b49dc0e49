"""Machines of any layout in time: pages of kernels, written once for all layouts, written out for one."""
