/* The host's side of frame.c. */
#include <stdio.h>

void put(const char *text) { fputs(text, stdout); }

int verdict(int passed) { return passed ? 0 : 1; }
