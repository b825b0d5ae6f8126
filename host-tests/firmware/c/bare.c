/* The bare-metal side of frame.c: vectors, memory, and semihosting, on Arm and RISC-V. */
#include <stdint.h>

extern uint32_t _stack_top, _data_start, _data_end, _data_load, _bss_start, _bss_end;
int main(void);

#if defined(__riscv)
/* QEMU knows the breakpoint by the instructions around it, which must not be compressed. */
#define SEMIHOST(number, argument)                                                        \
  __asm__ volatile(".option push\n.option norvc\n.balign 16\n"                            \
                   "slli zero, zero, 0x1f\nebreak\nsrai zero, zero, 7\n.option pop"       \
                   : "+r"(number)                                                         \
                   : "r"(argument)                                                        \
                   : "memory")
#define NUMBER "a0"
#define ARGUMENT "a1"
#else
#define SEMIHOST(number, argument) __asm__ volatile("bkpt 0xab" : "+r"(number) : "r"(argument) : "memory")
#define NUMBER "r0"
#define ARGUMENT "r1"
#endif

static int semihost(int operation, const void *block) {
  register int number __asm__(NUMBER) = operation;
  register const void *argument __asm__(ARGUMENT) = block;
  SEMIHOST(number, argument);
  return number;
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
#if defined(__arm__)
  /* The floating-point unit, where there is one: code for it may save its registers. */
  *(volatile uint32_t *)0xe000ed88 |= 0xf << 20;
#endif
  main();
  for (;;) {
  }
}

#if defined(__riscv)
/* mtvec keeps its two low bits for itself. */
__attribute__((aligned(4)))
#endif
void fault(void) {
  put("panic: a fault\n");
  verdict(0);
}

#if defined(__riscv)
__asm__(".section .vectors, \"ax\"\n"
        ".global start\n"
        "start: la sp, _stack_top\n"
        "la t0, fault\n"
        "csrw mtvec, t0\n"
        "j reset\n"
        ".text\n");
#else
void start(void) __attribute__((alias("reset")));

/* A vector is the initial stack pointer or a handler. */
typedef union {
  void (*handler)(void);
  void *stack;
} Vector;

__attribute__((section(".vectors"), used)) static const Vector vectors[16] = {
    {.stack = &_stack_top},  {.handler = start}, {.handler = fault}, {.handler = fault},
    {.handler = fault}, {.handler = fault}, {.handler = fault},
};
#endif
