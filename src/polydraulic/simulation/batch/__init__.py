"""Many machines at once: `batch_inputs` checks and prepares them, `lanes` steps 64 side by side, `batch` runs blocks on all processors."""
