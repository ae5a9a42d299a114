/* A wall clock that is ahead of the real one by as many seconds as the file RTKIT_TEST_CLOCK says,
   and runs faster since a monotonic moment: three numbers of eight bytes (seconds, millionths,
   moment in nanoseconds), in memory that all processes share. Loaded before libc (LD_PRELOAD). It needs no
   header, so that a bare compiler is enough. The monotonic clocks are left alone. */

struct timespec { long tv_sec; long tv_nsec; };
struct timeval { long tv_sec; long tv_usec; };

extern long syscall(long, ...);
extern char *getenv(const char *);
extern int open(const char *, int, ...);
extern void *mmap(void *, unsigned long, int, int, int, long);

#if defined(__x86_64__)
#define CLOCK_GETTIME 228
#elif defined(__aarch64__) || defined(__riscv)
#define CLOCK_GETTIME 113
#else
#error "which system call asks a clock here?"
#endif

static volatile long *ahead_s;

__attribute__((constructor)) static void begin(void)
{
    const char *path = getenv("RTKIT_TEST_CLOCK");
    int file = path ? open(path, 0x80000) : -1; /* read-only, not for children */
    void *memory = file < 0 ? (void *)-1 : mmap(0, 3 * sizeof(long), 1, 1, file, 0);
    if (memory != (void *)-1)
        ahead_s = memory;
}

static void shift(struct timespec *now)
{
    struct timespec steady;
    long ahead_ns = 0;
    if (ahead_s[1] && !syscall(CLOCK_GETTIME, 1L, &steady))
        ahead_ns = (steady.tv_sec * 1000000000L + steady.tv_nsec - ahead_s[2]) / 1000000L * ahead_s[1];
    ahead_ns += now->tv_nsec;
    now->tv_sec += ahead_s[0] + ahead_ns / 1000000000L;
    now->tv_nsec = ahead_ns % 1000000000L;
}

static int is_wall(int clock) { return clock == 0 || clock == 5 || clock == 11; }

int clock_gettime(int clock, struct timespec *now)
{
    int failed = syscall(CLOCK_GETTIME, (long)clock, now) ? -1 : 0;
    if (!failed && ahead_s && is_wall(clock))
        shift(now);
    return failed;
}

int gettimeofday(struct timeval *now, void *zone)
{
    struct timespec exact = {0, 0};
    (void)zone;
    clock_gettime(0, &exact);
    if (now) {
        now->tv_sec = exact.tv_sec;
        now->tv_usec = exact.tv_nsec / 1000;
    }
    return 0;
}

long time(long *out)
{
    struct timespec exact = {0, 0};
    clock_gettime(0, &exact);
    if (out)
        *out = exact.tv_sec;
    return exact.tv_sec;
}
