"""Publishing runs: terms, citation, badge."""
