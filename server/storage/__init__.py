"""Where the service keeps files: data folder, object storage, who may read them."""
