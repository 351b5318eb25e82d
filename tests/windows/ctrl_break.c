// Starts a program and gives it Ctrl-Break twice, as the key of a console does.
//
// Wine 8 has no such key, and its GenerateConsoleCtrlEvent knows Ctrl-C only. The system delivers both in one way: it starts a thread in the
// program, at CtrlRoutine of kernelbase.dll, with the number of the event. This does the same.
//
// usage: ctrl_break SECONDS PAUSE COMMAND LINE...; the exit code is that of the program.
#include <stdio.h>
#include <stdlib.h>
#include <wchar.h>
#include <windows.h>

int wmain(int count, wchar_t **words) {
    wchar_t line[4096] = L"";
    STARTUPINFOW start = {sizeof start};
    PROCESS_INFORMATION process;
    DWORD code = 1;
    if (count < 4) return 2;
    for (int k = 3; k < count; k++) {
        wcscat(line, L"\"");
        wcscat(line, words[k]);
        wcscat(line, k + 1 < count ? L"\" " : L"\"");
    }
    if (!CreateProcessW(NULL, line, NULL, NULL, TRUE, 0, NULL, NULL, &start, &process)) {
        fprintf(stderr, "cannot start: %lu\n", GetLastError());
        return 3;
    }
    Sleep(1000 * _wtoi(words[1]));
    void *routine = (void *)GetProcAddress(GetModuleHandleW(L"kernelbase.dll"), "CtrlRoutine");
    for (int k = 0; k < 2; k++) {
        void *event = (void *)(ULONG_PTR)CTRL_BREAK_EVENT;
        if (!routine || !CreateRemoteThread(process.hProcess, NULL, 0, (LPTHREAD_START_ROUTINE)routine, event, 0, NULL)) {
            fprintf(stderr, "cannot send: %lu\n", GetLastError());
            TerminateProcess(process.hProcess, 4);
        }
        Sleep(1000 * _wtoi(words[2]));
    }
    if (WaitForSingleObject(process.hProcess, 10000) != WAIT_OBJECT_0) TerminateProcess(process.hProcess, 5);
    GetExitCodeProcess(process.hProcess, &code);
    return code;
}
