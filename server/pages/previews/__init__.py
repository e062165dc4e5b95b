"""What a link to a page shows elsewhere: texts and a picture."""
