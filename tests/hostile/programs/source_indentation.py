class Controller:
def step(self): pass
