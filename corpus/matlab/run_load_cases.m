function x = run_load_cases(work, command, cases)
%RUN_LOAD_CASES  Equilibrium of run.adm in every load case.
%
%   x = run_load_cases(work, command, cases) writes WORK/run.acf, executes COMMAND in the folder WORK and returns what READ_XRF
%   reads from run.res. Its equilibria are the load cases, in their order.

acf = fopen(fullfile(work, 'run.acf'), 'w');
if acf < 0
    error('run_load_cases: cannot write in %s', work);
end
fprintf(acf, '\nfile/model=run\n');  % the empty first line answers the question for a model
for l = 1:size(cases.load, 1)
    for k = 1:length(cases.sforce)
        fprintf(acf, 'SFORCE/%d, FUNCTION = %.15g\n', cases.sforce(k), cases.load(l, k));
    end
    fprintf(acf, 'SIMULATE/STATIC\n');
end
fprintf(acf, 'STOP\n');
fclose(acf);

here = pwd;
cd(work);
if ispc
    [status, text] = dos(command);
else
    [status, text] = unix(command);
end
cd(here);
if status ~= 0
    error('run_load_cases: "%s" gave %d\n%s', command, status, text);
end
x = read_xrf(fullfile(work, 'run.res'));
if sum(x.equilibrium) ~= size(cases.load, 1)
    error('run_load_cases: %d equilibria for %d load cases, see run.msg', sum(x.equilibrium), size(cases.load, 1));
end
