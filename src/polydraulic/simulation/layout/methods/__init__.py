"""Methods that integrate a machine of any layout in continuous time: their pages, and what drives them."""
