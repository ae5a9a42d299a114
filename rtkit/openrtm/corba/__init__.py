"""Names of CORBA, omniORB and the module `RTC`: data, objects and services, without a broker.

Mutable twins of data types, references to objects, the modules that omniidl would generate of IDL
files, and calls of the interfaces that these declare.
"""
