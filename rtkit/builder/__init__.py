"""The RTC Builder: RTC profiles and IDL files in, source of components out, and back.

Pure: texts in, texts out. Reading and writing of files is the command's.
"""
