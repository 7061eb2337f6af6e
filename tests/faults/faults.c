// SPDX-License-Identifier: Apache-2.0
// Preloaded into the program: the QUENCH_FAULT_AT-th call that writes a file (open for writing, write, close, rename)
// goes wrong. QUENCH_FAULT says how: "full" (it and all later ones fail as on a full disk), "once" (it alone fails),
// "kill", "interrupt" or "interrupt twice" (signals arrive). When it happens, the name of the call goes into the file QUENCH_FAULT_MARK.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/uio.h>
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

static int goes_wrong(const char* call) {
  const int at = atoi(text("QUENCH_FAULT_AT"));
  const int now = ++calls;
  if (at <= 0 || now < at) return 0;
  const char* how = text("QUENCH_FAULT");
  const int full = strcmp(how, "full") == 0;
  if (now > at) return full;
  const int mark = open(text("QUENCH_FAULT_MARK"), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (mark >= 0) {
    if (real_write()(mark, call, strlen(call)) < 0) abort();
    close(mark);
  }
  if (strcmp(how, "kill") == 0) raise(SIGKILL);
  if (strncmp(how, "interrupt", 9) == 0) {
    raise(SIGINT);
    if (strcmp(how, "interrupt twice") == 0) raise(SIGINT);
    return 0;
  }
  return 1;
}

static int known(int fd) { return fd >= 0 && fd < 4096 && written_to[fd]; }

static FILE* opened(const char* name, const char* path, const char* mode) {
  FILE* (*real)(const char*, const char*) = (FILE * (*)(const char*, const char*)) dlsym(RTLD_NEXT, name);
  if (!strchr(mode, 'w')) return real(path, mode);
  if (goes_wrong("open")) {
    errno = ENOSPC;
    return NULL;
  }
  FILE* file = real(path, mode);
  if (file && fileno(file) < 4096) written_to[fileno(file)] = 1;
  return file;
}
FILE* fopen(const char* path, const char* mode) { return opened("fopen", path, mode); }
FILE* fopen64(const char* path, const char* mode) { return opened("fopen64", path, mode); }

ssize_t write(int fd, const void* bytes, size_t size) {
  if (known(fd) && goes_wrong("write")) {
    errno = ENOSPC;
    return -1;
  }
  return real_write()(fd, bytes, size);
}

ssize_t writev(int fd, const struct iovec* parts, int count) {
  ssize_t (*real)(int, const struct iovec*, int) =
      (ssize_t(*)(int, const struct iovec*, int))dlsym(RTLD_NEXT, "writev");
  if (known(fd) && goes_wrong("write")) {
    errno = ENOSPC;
    return -1;
  }
  return real(fd, parts, count);
}

int fclose(FILE* file) {
  int (*real)(FILE*) = (int (*)(FILE*))dlsym(RTLD_NEXT, "fclose");
  const int fd = fileno(file);
  if (!known(fd)) return real(file);
  written_to[fd] = 0;
  const int wrong = goes_wrong("close");
  const int result = real(file);
  if (!wrong) return result;
  errno = EIO;
  return EOF;
}

int rename(const char* from, const char* to) {
  int (*real)(const char*, const char*) = (int (*)(const char*, const char*))dlsym(RTLD_NEXT, "rename");
  if (goes_wrong("rename")) {
    errno = EIO;
    return -1;
  }
  return real(from, to);
}
