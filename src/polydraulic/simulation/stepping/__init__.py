"""Machines moved step by step: `simulator` one, `batch_simulator` many, both around drivers that `text` writes for a layout."""
