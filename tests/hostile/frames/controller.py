# Appended to each file of attacks: a program that makes one of them, by name, at its first step.


class Controller:
    def __init__(self, config):
        self.attack = globals()[config["attack"]]

    def step(self, observation):
        attack, self.attack = self.attack, lambda observation: None
        try:
            got = attack(observation)
        except BlockingIOError:  # no process may be started: a limit, no refusal
            raise
        except HELD as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)
        return [0.0, 0.0, 0.0, 0.0]
