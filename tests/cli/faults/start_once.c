// SPDX-License-Identifier: Apache-2.0
// Preloaded into the program, so that tests which run it thousands of times load its libraries once: before main() the
// process listens on the socket QUENCH_START_SOCKET, and for every request it forks a child, which takes the streams,
// the folder, the environment and the arguments of the request and calls main() with them. It ends when nobody holds
// the other end of the socket. Requests and replies are those of support/program_starter.h.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

struct request {
  int32_t child;  // whose end is waited for; 0: starts one
  uint32_t bytes, arguments, variables;
};

static int (*real_main)(int, char**, char**);

static int take(int from, void* to, size_t size) {
  for (char* at = to; size > 0;) {
    const ssize_t got = read(from, at, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return 0;
    at += got;
    size -= (size_t)got;
  }
  return 1;
}

// The strings that follow, each with its end; returns where they end.
static char* split(char* at, char** list, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    list[i] = at;
    at += strlen(at) + 1;
  }
  list[count] = NULL;
  return at;
}

static int become(const struct request* request, char* text, const int* streams) {
  for (int i = 0; i < 3; ++i)
    if (dup2(streams[i], i) < 0) _exit(127);
  for (int i = 0; i < 3; ++i)
    if (streams[i] > 2) close(streams[i]);
  char** arguments = malloc((request->arguments + 1) * sizeof *arguments);
  char** variables = malloc((request->variables + 1) * sizeof *variables);
  if (!arguments || !variables || chdir(text) != 0) _exit(127);
  split(split(text + strlen(text) + 1, arguments, request->arguments), variables, request->variables);
  environ = variables;
  return real_main((int)request->arguments, arguments, variables);
}

static int serve(int argc, char** argv, char** envp) {
  const char* number = getenv("QUENCH_START_SOCKET");
  if (!number) return real_main(argc, argv, envp);
  const int socket = atoi(number);
  for (;;) {
    struct request request;
    union {
      char bytes[CMSG_SPACE(3 * sizeof(int))];
      struct cmsghdr aligned;
    } control;
    struct iovec part = {&request, sizeof request};
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control};
    const ssize_t got = recvmsg(socket, &message, MSG_CMSG_CLOEXEC | MSG_WAITALL);
    if (got != (ssize_t)sizeof request) _exit(0);
    int32_t reply = 0;
    if (request.child > 0) {
      int status = 0;
      reply = waitpid(request.child, &status, 0) == request.child ? status : -1;
    } else {
      const struct cmsghdr* held = CMSG_FIRSTHDR(&message);
      char* text = malloc(request.bytes);
      int streams[3];
      if (!held || !text || !take(socket, text, request.bytes)) _exit(1);
      memcpy(streams, CMSG_DATA(held), sizeof streams);
      reply = fork();
      if (reply == 0) {
        close(socket);
        return become(&request, text, streams);
      }
      for (int i = 0; i < 3; ++i) close(streams[i]);
      free(text);
    }
    if (write(socket, &reply, sizeof reply) != (ssize_t)sizeof reply) _exit(1);
  }
}

// GDCM frees its dictionaries entry by entry in the end, which takes longer than most runs: it is left out.
int __cxa_atexit(void (*call)(void*), void* of, void* library) {
  Dl_info where;
  if (library && dladdr(library, &where) && where.dli_fname && strstr(where.dli_fname, "/libgdcm")) return 0;
  return ((int (*)(void (*)(void*), void*, void*))dlsym(RTLD_NEXT, "__cxa_atexit"))(call, of, library);
}

int __libc_start_main(int (*program)(int, char**, char**), int argc, char** argv, void (*init)(void), void (*fini)(void),
                      void (*loader_fini)(void), void* stack) {
  int (*real)(int (*)(int, char**, char**), int, char**, void (*)(void), void (*)(void), void (*)(void), void*) =
      dlsym(RTLD_NEXT, "__libc_start_main");
  real_main = program;
  return real(serve, argc, argv, init, fini, loader_fini, stack);
}
