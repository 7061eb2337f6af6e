// SPDX-License-Identifier: Apache-2.0
// Preloaded into the program: the QUENCH_FAULT_AT-th call that writes a file (open for writing, write, flush to the
// disk, close, rename) or makes a folder goes wrong. QUENCH_FAULT says how: "full" (it and all later ones fail as on a full disk), "once"
// (it alone fails), "kill", "interrupt" or "interrupt twice" (signals arrive). When it happens, the name of the call
// goes into the file QUENCH_FAULT_MARK. Opening the file QUENCH_DEAD_FILE never returns, and no signal but SIGKILL ends
// it, as with a file on a network disk that does not answer. With QUENCH_NO_EXCHANGE two names cannot be exchanged in one
// step, as on some file systems.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

static atomic_int calls;
static atomic_char written_to[4096];  // per descriptor: opened for writing

static const char* text(const char* name) {
  const char* value = getenv(name);
  return value ? value : "";
}

static ssize_t (*real_write(void))(int, const void*, size_t) {
  return (ssize_t(*)(int, const void*, size_t))dlsym(RTLD_NEXT, "write");
}
static int (*real_open(void))(const char*, int, ...) {
  return (int (*)(const char*, int, ...))dlsym(RTLD_NEXT, "open");
}
static int (*real_close(void))(int) { return (int (*)(int))dlsym(RTLD_NEXT, "close"); }

// To the process, where a thread of it waits for signals; returns when it has taken this one.
static void interrupt(void) {
  kill(getpid(), SIGINT);
  const struct timespec moment = {0, 1000000};
  for (sigset_t pending; sigpending(&pending) == 0 && sigismember(&pending, SIGINT);) nanosleep(&moment, NULL);
}

static void mark(const char* call) {
  const int file = real_open()(text("QUENCH_FAULT_MARK"), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0) return;
  if (real_write()(file, call, strlen(call)) < 0) abort();
  real_close()(file);
}

static int goes_wrong(const char* call) {
  const int at = atoi(text("QUENCH_FAULT_AT"));
  const int now = ++calls;
  if (at <= 0 || now < at) return 0;
  const char* how = text("QUENCH_FAULT");
  const int full = strcmp(how, "full") == 0;
  if (now > at) return full;
  mark(call);
  if (strcmp(how, "kill") == 0) raise(SIGKILL);
  if (strncmp(how, "interrupt", 9) == 0) {
    interrupt();
    if (strcmp(how, "interrupt twice") != 0) return 0;
    interrupt();
    for (;;) pause();  // until the signal has ended the process
  }
  return 1;
}

static int known(int fd) { return fd >= 0 && fd < 4096 && written_to[fd]; }

// In vfork() the caller waits for its child and for SIGKILL only.
static void never_answer(void) {
  mark("dead");
  const pid_t child = vfork();
  if (child != 0) return;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (;;) pause();
}

static int opened(const char* path, int flags, mode_t mode) {
  const char* dead = text("QUENCH_DEAD_FILE");
  if (*dead && strcmp(path, dead) == 0) never_answer();
  const int writes = (flags & O_ACCMODE) != O_RDONLY && strcmp(path, "/dev/null") != 0;
  if (writes && goes_wrong("open")) {
    errno = ENOSPC;
    return -1;
  }
  const int fd = real_open()(path, flags, mode);
  if (writes && fd >= 0 && fd < 4096) written_to[fd] = 1;
  return fd;
}
#define MODE_OF(flags)                   \
  mode_t mode = 0;                       \
  if ((flags) & (O_CREAT | O_TMPFILE)) { \
    va_list more;                        \
    va_start(more, flags);               \
    mode = (mode_t)va_arg(more, int);    \
    va_end(more);                        \
  }
int open(const char* path, int flags, ...) {
  MODE_OF(flags)
  return opened(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  MODE_OF(flags)
  return opened(path, flags, mode);
}

// The library of C++ reads through it.
static FILE* opened_stream(const char* name, const char* path, const char* mode) {
  const char* dead = text("QUENCH_DEAD_FILE");
  if (*dead && strcmp(path, dead) == 0) never_answer();
  return ((FILE * (*)(const char*, const char*)) dlsym(RTLD_NEXT, name))(path, mode);
}
FILE* fopen(const char* path, const char* mode) { return opened_stream("fopen", path, mode); }
FILE* fopen64(const char* path, const char* mode) { return opened_stream("fopen64", path, mode); }

ssize_t write(int fd, const void* bytes, size_t size) {
  if (known(fd) && goes_wrong("write")) {
    errno = ENOSPC;
    return -1;
  }
  return real_write()(fd, bytes, size);
}

int fsync(int fd) {
  int (*real)(int) = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
  if (goes_wrong(known(fd) ? "flush" : "flush folder")) {
    errno = EIO;
    return -1;
  }
  return real(fd);
}

int syncfs(int fd) {
  int (*real)(int) = (int (*)(int))dlsym(RTLD_NEXT, "syncfs");
  if (goes_wrong("flush")) {
    errno = EIO;
    return -1;
  }
  return real(fd);
}

int mkdir(const char* path, mode_t mode) {
  int (*real)(const char*, mode_t) = (int (*)(const char*, mode_t))dlsym(RTLD_NEXT, "mkdir");
  if (goes_wrong("mkdir")) {
    errno = ENOSPC;
    return -1;
  }
  return real(path, mode);
}

int close(int fd) {
  if (!known(fd)) return real_close()(fd);
  written_to[fd] = 0;
  const int wrong = goes_wrong("close");
  const int result = real_close()(fd);
  if (!wrong) return result;
  errno = EIO;
  return -1;
}

int rename(const char* from, const char* to) {
  int (*real)(const char*, const char*) = (int (*)(const char*, const char*))dlsym(RTLD_NEXT, "rename");
  if (goes_wrong("rename")) {
    errno = EIO;
    return -1;
  }
  return real(from, to);
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
  int (*real)(int, const char*, int, const char*, unsigned) =
      (int (*)(int, const char*, int, const char*, unsigned))dlsym(RTLD_NEXT, "renameat2");
  if (*text("QUENCH_NO_EXCHANGE")) {
    errno = EINVAL;
    return -1;
  }
  if (goes_wrong("rename")) {
    errno = EIO;
    return -1;
  }
  return real(from_folder, from, to_folder, to, flags);
}
