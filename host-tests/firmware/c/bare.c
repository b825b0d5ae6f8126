/* The bare-metal side of frame.c: vectors, memory, and Arm semihosting. */
#include <stdint.h>

extern uint32_t _stack_top, _data_start, _data_end, _data_load, _bss_start, _bss_end;
int main(void);

static int semihost(int operation, const void *argument) {
  register int r0 __asm__("r0") = operation;
  register const void *r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

void put(const char *text) { semihost(4, text); }

int verdict(int passed) {
  /* Exit with a code: ADP_Stopped_ApplicationExit. */
  const uint32_t block[2] = {0x20026, passed ? 0 : 1};
  semihost(0x20, block);
  return 1;
}

void reset(void) {
  for (uint32_t *to = &_data_start, *from = &_data_load; to < &_data_end;) {
    *to++ = *from++;
  }
  for (uint32_t *at = &_bss_start; at < &_bss_end;) {
    *at++ = 0;
  }
  /* The floating-point unit, where there is one: code for it may save its registers. */
  *(volatile uint32_t *)0xe000ed88 |= 0xf << 20;
  main();
  for (;;) {
  }
}

void fault(void) {
  put("panic: a fault\n");
  verdict(0);
}

/* A vector is the initial stack pointer or a handler. */
typedef union {
  void (*handler)(void);
  void *stack;
} Vector;

__attribute__((section(".vectors"), used)) static const Vector vectors[16] = {
    {.stack = &_stack_top},  {.handler = reset}, {.handler = fault}, {.handler = fault},
    {.handler = fault}, {.handler = fault}, {.handler = fault},
};
