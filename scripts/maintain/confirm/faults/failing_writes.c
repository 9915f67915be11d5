/* Lets calls that write below a folder fail, or kill the process before one of them.

   Loaded with LD_PRELOAD. A process is left alone until fault_arm is called in it; its children are
   left alone, too. Calls are counted in memory that a parent shares with the processes it forks, so
   that the parent knows how far one of them came before it was killed. */

#define _GNU_SOURCE
#undef _FORTIFY_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static char folder[PATH_MAX];
static int failing, code, killing, lasting;
/* [0] calls so far; [1] whether one was disturbed. */
static int *shared;
static char *told;

/* Memory that this process and those it forks later share. */
void fault_share(void) {
    shared = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    told = (char *)(shared + 2);
}

int fault_calls(void) { return shared[0]; }
int fault_disturbed(void) { return shared[1]; }
const char *fault_told(void) { return told; }

/* From call `at` on: fail with `error`, that call alone or, if `last`, every later one that needs
   space as well; or, if `kill`, kill the process group. at = 0: count only. */
void fault_arm(const char *below, int at, int error, int last, int kill_group) {
    shared[0] = shared[1] = 0;
    told[0] = 0;
    failing = at, code = error, lasting = last, killing = kill_group;
    snprintf(folder, sizeof folder, "%s", below);
}

static int below(const char *path) {
    size_t length = strlen(folder);
    return strncmp(path, folder, length) == 0 && (path[length] == 0 || path[length] == '/');
}

static int below_handle(int handle) {
    char link[64], path[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", handle);
    ssize_t size = readlink(link, path, sizeof path - 1);
    if (size < 0) return 0;
    path[size] = 0;
    return below(path);
}

static int below_at(int place, const char *path) {
    char full[PATH_MAX * 2], link[64], home[PATH_MAX];
    if (path[0] == '/') return below(path);
    snprintf(link, sizeof link, place == AT_FDCWD ? "/proc/self/cwd" : "/proc/self/fd/%d", place);
    ssize_t size = readlink(link, home, sizeof home - 1);
    if (size < 0) return 0;
    home[size] = 0;
    snprintf(full, sizeof full, "%s/%s", home, path);
    return below(full);
}

enum { FINE, FAIL, KILL };

/* Counts one call; says what is to become of it. A call that frees space goes on on a full disk. */
static int turn(const char *name, int needs_space) {
    int number = ++shared[0];
    if (failing == 0 || number < failing) return FINE;
    if (number > failing && !(lasting && needs_space)) return FINE;
    if (lasting && !needs_space && !killing) return FINE;
    if (!shared[1]) snprintf(told, 1024, "%s", name);
    shared[1] = 1;
    return killing ? KILL : FAIL;
}

static void end(void) {
    kill(0, SIGKILL);
    for (;;) pause();
}

#define ORIGINAL(name, type) \
    static __typeof__(type) *original; \
    if (!original) original = dlsym(RTLD_NEXT, name)

/* One call that either happens or does not. */
#define WHOLE(concerned, name, needs_space, call) \
    if (folder[0] && (concerned)) { \
        int what = turn(name, needs_space); \
        if (what == KILL) end(); \
        if (what == FAIL) { errno = code; return -1; } \
    } \
    return call

/* A kill, or a disk that is full, comes in the middle: half of the bytes are written before. */
#define WRITING(name, handle, size, half, whole) \
    if (folder[0] && below_handle(handle)) { \
        int first = !shared[1], what = turn(name, 1); \
        if (what != FINE && (killing || lasting) && first && (size) > 1) { \
            ssize_t written = half; \
            if (what == KILL) end(); \
            return written; \
        } \
        if (what == KILL) end(); \
        if (what == FAIL) { errno = code; return -1; } \
    } \
    return whole

ssize_t write(int handle, const void *data, size_t size) {
    ORIGINAL("write", ssize_t(int, const void *, size_t));
    WRITING("write", handle, size, original(handle, data, size / 2), original(handle, data, size));
}

static ssize_t at_place(int handle, const void *data, size_t size, off_t place) {
    ORIGINAL("pwrite64", ssize_t(int, const void *, size_t, off_t));
    WRITING("pwrite", handle, size, original(handle, data, size / 2, place),
            original(handle, data, size, place));
}
ssize_t pwrite(int handle, const void *data, size_t size, off_t place) {
    return at_place(handle, data, size, place);
}
ssize_t pwrite64(int handle, const void *data, size_t size, off_t place) {
    return at_place(handle, data, size, place);
}

ssize_t writev(int handle, const struct iovec *parts, int count) {
    ORIGINAL("writev", ssize_t(int, const struct iovec *, int));
    WHOLE(below_handle(handle), "writev", 1, original(handle, parts, count));
}

static ssize_t sent(int target, int source, off_t *place, size_t size) {
    ORIGINAL("sendfile64", ssize_t(int, int, off_t *, size_t));
    WRITING("sendfile", target, size, original(target, source, place, 1),
            original(target, source, place, size));
}
ssize_t sendfile(int target, int source, off_t *place, size_t size) {
    return sent(target, source, place, size);
}
ssize_t sendfile64(int target, int source, off_t *place, size_t size) {
    return sent(target, source, place, size);
}

ssize_t copy_file_range(int source, off_t *from, int target, off_t *to, size_t size,
                        unsigned flags) {
    ORIGINAL("copy_file_range", ssize_t(int, off_t *, int, off_t *, size_t, unsigned));
    WHOLE(below_handle(target), "copy_file_range", 1,
          original(source, from, target, to, size, flags));
}

#define WRITES(flags) (((flags) & O_ACCMODE) != O_RDONLY || ((flags) & O_CREAT))

static int opened(int place, const char *path, int flags, mode_t mode) {
    ORIGINAL("openat64", int(int, const char *, int, ...));
    WHOLE(WRITES(flags) && below_at(place, path), "open", (flags) & O_CREAT,
          original(place, path, flags, mode));
}

#define WITH_MODE(flags) \
    mode_t mode = 0; \
    if ((flags) & (O_CREAT | O_TMPFILE)) { \
        va_list rest; \
        va_start(rest, flags); \
        mode = va_arg(rest, mode_t); \
        va_end(rest); \
    }

int open(const char *path, int flags, ...) {
    WITH_MODE(flags)
    return opened(AT_FDCWD, path, flags, mode);
}
int open64(const char *path, int flags, ...) {
    WITH_MODE(flags)
    return opened(AT_FDCWD, path, flags, mode);
}
int openat(int place, const char *path, int flags, ...) {
    WITH_MODE(flags)
    return opened(place, path, flags, mode);
}
int openat64(int place, const char *path, int flags, ...) {
    WITH_MODE(flags)
    return opened(place, path, flags, mode);
}

int fsync(int handle) {
    ORIGINAL("fsync", int(int));
    WHOLE(below_handle(handle), "fsync", 1, original(handle));
}
int fdatasync(int handle) {
    ORIGINAL("fdatasync", int(int));
    WHOLE(below_handle(handle), "fdatasync", 1, original(handle));
}

static int cut(int handle, off_t size) {
    ORIGINAL("ftruncate64", int(int, off_t));
    WHOLE(below_handle(handle), "ftruncate", 0, original(handle, size));
}
int ftruncate(int handle, off_t size) { return cut(handle, size); }
int ftruncate64(int handle, off_t size) { return cut(handle, size); }

int rename(const char *from, const char *to) {
    ORIGINAL("rename", int(const char *, const char *));
    WHOLE(below_at(AT_FDCWD, to), "rename", 1, original(from, to));
}
int renameat(int one, const char *from, int two, const char *to) {
    ORIGINAL("renameat", int(int, const char *, int, const char *));
    WHOLE(below_at(two, to), "renameat", 1, original(one, from, two, to));
}
int renameat2(int one, const char *from, int two, const char *to, unsigned flags) {
    ORIGINAL("renameat2", int(int, const char *, int, const char *, unsigned));
    WHOLE(below_at(two, to), "renameat2", 1, original(one, from, two, to, flags));
}

int link(const char *from, const char *to) {
    ORIGINAL("link", int(const char *, const char *));
    WHOLE(below_at(AT_FDCWD, to), "link", 1, original(from, to));
}
int linkat(int one, const char *from, int two, const char *to, int flags) {
    ORIGINAL("linkat", int(int, const char *, int, const char *, int));
    WHOLE(below_at(two, to), "linkat", 1, original(one, from, two, to, flags));
}
int symlink(const char *from, const char *to) {
    ORIGINAL("symlink", int(const char *, const char *));
    WHOLE(below_at(AT_FDCWD, to), "symlink", 1, original(from, to));
}

int mkdir(const char *path, mode_t mode) {
    ORIGINAL("mkdir", int(const char *, mode_t));
    WHOLE(below_at(AT_FDCWD, path), "mkdir", 1, original(path, mode));
}
int mkdirat(int place, const char *path, mode_t mode) {
    ORIGINAL("mkdirat", int(int, const char *, mode_t));
    WHOLE(below_at(place, path), "mkdirat", 1, original(place, path, mode));
}

int unlink(const char *path) {
    ORIGINAL("unlink", int(const char *));
    WHOLE(below_at(AT_FDCWD, path), "unlink", 0, original(path));
}
int unlinkat(int place, const char *path, int flags) {
    ORIGINAL("unlinkat", int(int, const char *, int));
    WHOLE(below_at(place, path), "unlinkat", 0, original(place, path, flags));
}
int rmdir(const char *path) {
    ORIGINAL("rmdir", int(const char *));
    WHOLE(below_at(AT_FDCWD, path), "rmdir", 0, original(path));
}

int chmod(const char *path, mode_t mode) {
    ORIGINAL("chmod", int(const char *, mode_t));
    WHOLE(below_at(AT_FDCWD, path), "chmod", 0, original(path, mode));
}
int fchmod(int handle, mode_t mode) {
    ORIGINAL("fchmod", int(int, mode_t));
    WHOLE(below_handle(handle), "fchmod", 0, original(handle, mode));
}
int fchmodat(int place, const char *path, mode_t mode, int flags) {
    ORIGINAL("fchmodat", int(int, const char *, mode_t, int));
    WHOLE(below_at(place, path), "fchmodat", 0, original(place, path, mode, flags));
}
int utimensat(int place, const char *path, const struct timespec times[2], int flags) {
    ORIGINAL("utimensat", int(int, const char *, const struct timespec *, int));
    WHOLE(below_at(place, path), "utimensat", 0, original(place, path, times, flags));
}
