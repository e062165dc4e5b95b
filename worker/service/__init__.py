"""The worker as a service: claims runs, drives them, stores results."""
