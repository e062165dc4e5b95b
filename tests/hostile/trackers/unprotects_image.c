/* Has the kernel make the picture writable, or give its pages back. */
#include <sys/mman.h>

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    void *page = (void *)((unsigned long)image->pixels & ~4095UL);
    if (!mprotect(page, 4096, PROT_READ | PROT_WRITE)) puts("GOT writable memory");
    if (!madvise(page, 4096, MADV_REMOVE)) puts("GOT the pages removed");
    if (mremap(page, 4096, 1 << 25, MREMAP_MAYMOVE) == MAP_FAILED) puts("it does not grow");
}
