"""Commands on documents: RTC and RTS profiles, code and pages made from them."""
