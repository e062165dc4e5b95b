exit(0);
