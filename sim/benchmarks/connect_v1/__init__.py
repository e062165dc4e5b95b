"""connect-v1: plug a connector into its receptacle with an arm."""
