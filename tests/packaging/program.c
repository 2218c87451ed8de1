// Stands in for Bathyscope in packages that are only looked at: `desktop --into FOLDER` copies what the real program wrote into SHARE.
#include <stdlib.h>
#ifndef _WIN32
#include <unistd.h>
#endif

int main(int count, char **words) {
#ifndef _WIN32
    if (count == 4)
        execlp("cp", "cp", "-rT", getenv("SHARE"), words[3], (char *)0);
#endif
    return 1;
}
