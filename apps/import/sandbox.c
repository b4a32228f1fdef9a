#include "sandbox.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

/* ---- limits ---- */

static void set_limit(__rlimit_resource_t resource, uint64_t soft, uint64_t hard) {
    struct rlimit limit, old;
    if (getrlimit(resource, &old) != 0) return;
    limit.rlim_max = hard < old.rlim_max ? hard : old.rlim_max;
    limit.rlim_cur = soft < limit.rlim_max ? soft : limit.rlim_max;
    setrlimit(resource, &limit);
}

/* The address space in use: the program, its libraries, its stack. */
static uint64_t own_size(void) {
    unsigned long long pages = 0;
    FILE *file = fopen("/proc/self/statm", "re");
    if (file == NULL) return (uint64_t)256 << 20;
    if (fscanf(file, "%llu", &pages) != 1) pages = 0;
    fclose(file);
    return pages * (uint64_t)sysconf(_SC_PAGESIZE);
}

static void set_limits(const sandbox_options *options) {
    set_limit(RLIMIT_CORE, 0, 0);
    set_limit(RLIMIT_NOFILE, 64, 64);
    if (options->memory_max) {
        /* Sanitizers reserve terabytes of addresses, which RLIMIT_AS would refuse. */
        if (!SANITIZED) {
            uint64_t size = own_size() + options->memory_max;
            set_limit(RLIMIT_AS, size, size);
        }
        /* The result, in its memory file, is all that is ever written. */
        signal(SIGXFSZ, SIG_IGN);
        set_limit(RLIMIT_FSIZE, options->memory_max, options->memory_max);
    }
    if (options->time_max) set_limit(RLIMIT_CPU, options->time_max, options->time_max + 1);
}

/* ---- Landlock: which files may be read. Called by number: the C library has no wrappers ---- */

/* linux/landlock.h of the oldest supported system lacks what later versions of the kernel know. */
typedef struct ruleset {
    uint64_t handled_access_fs, handled_access_net, scoped;
} ruleset;
enum {
    ACCESS_VERSION_1 = (1 << 13) - 1, /* EXECUTE .. MAKE_SYM */
    ACCESS_REFER = 1 << 13,           /* from version 2 */
    ACCESS_TRUNCATE = 1 << 14,        /* 3 */
    ACCESS_IOCTL_DEV = 1 << 15,       /* 5 */
    ACCESS_NET = 3,                   /* 4: bind and connect TCP */
    SCOPE_ALL = 3                     /* 6: abstract sockets, signals */
};

static int create_ruleset(void) {
    long version = syscall(__NR_landlock_create_ruleset, NULL, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (version < 1) return -1;
    ruleset rules = {.handled_access_fs = ACCESS_VERSION_1};
    size_t size = sizeof rules.handled_access_fs;
    if (version >= 2) rules.handled_access_fs |= ACCESS_REFER;
    if (version >= 3) rules.handled_access_fs |= ACCESS_TRUNCATE;
    if (version >= 4) {
        rules.handled_access_net = ACCESS_NET;
        size = offsetof(ruleset, scoped);
    }
    if (version >= 5) rules.handled_access_fs |= ACCESS_IOCTL_DEV;
    if (version >= 6) {
        rules.scoped = SCOPE_ALL;
        size = sizeof rules;
    }
    return (int)syscall(__NR_landlock_create_ruleset, &rules, size, 0);
}

/* What does not exist needs no rule. */
static void allow_reading(int rules, const char *path, bool folder) {
    int fd = open(path, O_PATH | O_CLOEXEC | (folder ? O_DIRECTORY : 0));
    if (fd < 0) return;
    struct landlock_path_beneath_attr beneath = {.allowed_access = LANDLOCK_ACCESS_FS_READ_FILE,
                                                 .parent_fd = fd};
    if (folder) beneath.allowed_access |= LANDLOCK_ACCESS_FS_READ_DIR;
    syscall(__NR_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &beneath, 0);
    close(fd);
}

static bool restrict_files(const sandbox_options *options) {
    int rules = create_ruleset();
    if (rules < 0) return false;
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s", options->file);
    char *slash = strrchr(folder, '/');
    if (slash == NULL)
        allow_reading(rules, ".", true);
    else if (slash != folder) { /* for a file in / the file alone, not the whole machine */
        *slash = '\0';
        allow_reading(rules, folder, true);
    }
    allow_reading(rules, options->file, false); /* it may be a link to elsewhere */
    for (size_t i = 0; i < options->allow_count; i++) allow_reading(rules, options->allow[i], true);
    bool done = syscall(__NR_landlock_restrict_self, rules, 0) == 0;
    close(rules);
    return done;
}

/* ---- seccomp: which system calls exist ---- */

#if defined(__x86_64__)
#define ARCHITECTURE AUDIT_ARCH_X86_64
#elif defined(__aarch64__)
#define ARCHITECTURE AUDIT_ARCH_AARCH64
#endif

/* Reading, memory, time, the end: nothing that leaves the process. */
static const uint16_t allowed[] = {
    __NR_read,
    __NR_readv,
    __NR_pread64,
    __NR_write,
    __NR_writev,
    __NR_lseek,
    __NR_close,
    __NR_fstat,
    __NR_newfstatat,
    __NR_statx,
    __NR_getdents64,
    __NR_getcwd,
    __NR_readlinkat,
    __NR_faccessat,
    __NR_faccessat2,
    __NR_ftruncate,
    __NR_munmap,
    __NR_mremap,
    __NR_brk,
    __NR_madvise,
    __NR_futex,
    __NR_clock_gettime,
    __NR_gettimeofday,
    __NR_getrandom,
    __NR_getrusage,
    __NR_sysinfo,
    __NR_sched_yield,
    __NR_sched_getaffinity,
    __NR_getpid,
    __NR_gettid,
    __NR_rt_sigaction,
    __NR_rt_sigprocmask,
    __NR_rt_sigreturn,
    __NR_sigaltstack,
    __NR_exit,
    __NR_exit_group,
    __NR_restart_syscall,
#ifdef __NR_stat /* the older names, which newer architectures lack */
    __NR_stat,
    __NR_lstat,
    __NR_readlink,
    __NR_access,
    __NR_time,
#endif
};

enum { FILTER_MAX = 256 };
typedef struct filter {
    struct sock_filter code[FILTER_MAX];
    unsigned short size;
} filter;

static void emit(filter *f, struct sock_filter instruction) {
    if (f->size < FILTER_MAX) f->code[f->size++] = instruction;
}

static void load(filter *f, size_t offset) {
    emit(f, (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, (uint32_t)offset));
}

static void give(filter *f, uint32_t action) {
    emit(f, (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, action));
}

/* Both supported architectures are little-endian: an argument's low half comes first. */
static size_t argument(int index, bool high) {
    return offsetof(struct seccomp_data, args) + 8 * (size_t)index + (high ? 4 : 0);
}

static const uint32_t refuse = SECCOMP_RET_ERRNO | EPERM;

/* nr: allowed if none of the bits is set in its argument. */
static void allow_without_bits(filter *f, uint32_t nr, int index, uint32_t bits) {
    emit(f, (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, nr, 0, 4));
    load(f, argument(index, false));
    emit(f, (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, bits, 0, 1));
    give(f, refuse);
    give(f, SECCOMP_RET_ALLOW);
    load(f, offsetof(struct seccomp_data, nr));
}

/* nr: allowed if its argument, all 64 bits, is `value`. */
static void allow_equal(filter *f, uint32_t nr, int index, uint32_t value) {
    emit(f, (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, nr, 0, 6));
    load(f, argument(index, false));
    emit(f, (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 3));
    load(f, argument(index, true));
    emit(f, (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, 0, 0, 1));
    give(f, SECCOMP_RET_ALLOW);
    give(f, refuse);
    load(f, offsetof(struct seccomp_data, nr));
}

#ifdef ARCHITECTURE
static void build_filter(filter *f) {
    load(f, offsetof(struct seccomp_data, arch));
    emit(f, (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ARCHITECTURE, 1, 0));
    give(f, SECCOMP_RET_KILL_PROCESS);
    load(f, offsetof(struct seccomp_data, nr));
    for (size_t i = 0; i < sizeof allowed / sizeof allowed[0]; i++) {
        emit(f, (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, allowed[i], 0, 1));
        give(f, SECCOMP_RET_ALLOW);
    }
    uint32_t writing =
        O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND | (O_TMPFILE & ~O_DIRECTORY);
    allow_without_bits(f, __NR_openat, 2, writing);
#ifdef __NR_open
    allow_without_bits(f, __NR_open, 1, writing);
#endif
    allow_without_bits(f, __NR_mmap, 2, PROT_EXEC);
    allow_without_bits(f, __NR_mprotect, 2, PROT_EXEC);
    allow_equal(f, __NR_prlimit64, 2, 0);               /* asking only */
    allow_equal(f, __NR_fcntl, 1, F_GETFL);             /* fdopen */
    allow_equal(f, __NR_tgkill, 0, (uint32_t)getpid()); /* abort */
    give(f, refuse);
}

static bool restrict_calls(void) {
    filter f = {.size = 0};
    build_filter(&f);
    struct sock_fprog program = {.len = f.size, .filter = f.code};
    return f.size < FILTER_MAX && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}
#else
static bool restrict_calls(void) { return false; }
#endif

const char *sandbox_enter(const sandbox_options *options) {
    set_limits(options);
    prctl(PR_SET_DUMPABLE, 0);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return "Landlock and seccomp";
    bool files = restrict_files(options), calls = restrict_calls();
    if (files) return calls ? "" : "seccomp";
    return calls ? "Landlock" : "Landlock and seccomp";
}
