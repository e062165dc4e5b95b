"""The data of a run: files, formats, series, scene, events; the recorded demo."""
