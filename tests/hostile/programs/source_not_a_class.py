Controller = 4
