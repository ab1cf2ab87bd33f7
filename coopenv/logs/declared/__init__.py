"""What a layout declares, part by part: units, the form of a text, files of several devices."""
