class Controller:
    def __init__(self, config):
        pass
