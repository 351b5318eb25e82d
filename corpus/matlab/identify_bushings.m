function [K, history] = identify_bushings(study, work, settings)
%IDENTIFY_BUSHINGS  Bushing stiffnesses from the measured positions of suspension parts.
%
%   K = identify_bushings(study, work) reads the deck, the load cases and the measured marks in the folder STUDY, runs ADAMS in
%   the folder WORK until the stiffnesses stay as they are, and returns one row Kx Ky Kz KTx KTy KTz per bushing in the units of
%   the deck (KT per radian). The last deck is left in WORK as identified.adm.
%
%   [K, history] = identify_bushings(study, work, settings) overrides the settings below, field by field; history(:, :, i) holds
%   the stiffnesses after iteration i.
%
%   The method: J. Meissonnier, J.-C. Fauroux, G. Gogu, C. Montezin, "Iterative identification of stiffness parameters in a car
%   suspension elastokinematic model". Equation numbers are those of that paper.
%
%   Needs no toolbox. MATLAB R2006a or newer, or GNU Octave.

set.command = 'mdi -c ru-standard i run.acf exit';  % what solves run.acf in the folder WORK
set.deck = 'model.adm';
set.load_cases = 'load_cases.csv';
set.loads = {'vertical', 3; 'lateral', 2; 'longitudinal', 1};  % column of the load cases, number of the SFORCE
set.marks_on_parts = 'marks_on_parts.csv';
set.marks_measured = 'marks_measured.csv';
set.bushings = [1 2];         % numbers of the BUSHING statements
set.round = [];               % those of them that are round: Kx = Ky, KTx = KTy (16)
set.initial = [1e4 1e4];      % newton/mm, newton.mm per degree
set.epsilon = 0.01;           % (17)
set.r_min = 0.75;             % (15)
set.inverse_slope = 0;        % 0: (13) as printed; 1: var(F)/cov(F,delta), right when only the deflections are noisy
set.weight_by_load = 0;       % 0: (16) as printed; 1: the more loaded direction weighs more
set.max_iterations = 200;
if nargin > 2
    names = fieldnames(settings);
    for k = 1:length(names)
        set.(names{k}) = settings.(names{k});
    end
end

deck = fullfile(study, set.deck);
model = read_bushings(deck, set.bushings);
cases = read_load_cases(fullfile(study, set.load_cases), set.loads);
delta = measured_deflections(model, cases, fullfile(study, set.marks_on_parts), fullfile(study, set.marks_measured));

n = length(set.bushings);
K = repmat([set.initial(1)*[1 1 1], set.initial(2)*180/pi*[1 1 1]], n, 1);
history = zeros(n, 6, 0);
converged = 0;
for iteration = 1:set.max_iterations
    write_bushings(deck, fullfile(work, 'run.adm'), set.bushings, K);
    F = bushing_forces(run_load_cases(work, set.command, cases), model);
    K_new = K;
    for b = 1:n
        for k = 1:6
            K_new(b, k) = regression(delta(:, k, b), F(:, k, b), K(b, k), set);
        end
        if any(set.round == set.bushings(b))
            K_new(b, 1:2) = radial(K_new(b, 1:2), F(:, 1:2, b), set);
            K_new(b, 4:5) = radial(K_new(b, 4:5), F(:, 4:5, b), set);
        end
    end
    change = max(abs(K_new(:)./K(:) - 1));
    K = K_new;
    history(:, :, iteration) = K;
    fprintf('iteration %3d: largest relative change %.4f\n', iteration, change);
    if change < set.epsilon  % (17)
        converged = 1;
        break
    end
end
if ~converged
    fprintf('not converged after %d iterations\n', set.max_iterations);
end
write_bushings(deck, fullfile(work, 'identified.adm'), set.bushings, K);

% -------------------------------------------------------------------------------------------------------------------------------
function delta = measured_deflections(model, cases, on_parts, measured)
% Deflections in each load case, (8): cases x 6 x bushings, lengths and radians, from the marks.
[parts, marks, p_part] = read_marks(on_parts, 0);
[parts_now, marks_now, p_now, labels] = read_marks(measured, 1);
n = length(model);
delta = zeros(length(cases.label), 6, n);
for l = 1:length(cases.label)
    here = strcmp(labels, cases.label{l});
    for b = 1:n
        A_I = part_pose(model(b).I.part_name, here, parts, marks, p_part, parts_now, marks_now, p_now);
        A_J = part_pose(model(b).J.part_name, here, parts, marks, p_part, parts_now, marks_now, p_now);
        delta(l, :, b) = bushing_deflection(A_I*model(b).I.B, A_J*model(b).J.B);
    end
end

% -------------------------------------------------------------------------------------------------------------------------------
function A = part_pose(part, here, parts, marks, p_part, parts_now, marks_now, p_now)
% Where the marks of a part say that it is, (3); ground does not move.
A = eye(4);
if isempty(part)
    return
end
on_part = find(strcmp(parts, part));
local = [];
global_ = [];
for k = on_part'
    seen = find(here & strcmp(parts_now, part) & marks_now == marks(k));
    if ~isempty(seen)
        local(:, end+1) = p_part(k, :)';
        global_(:, end+1) = p_now(seen(1), :)';
    end
end
if size(local, 2) < 3
    error('identify_bushings: fewer than three marks of part %s in a load case', part);
end
A = absolute_orientation(local, global_);

% -------------------------------------------------------------------------------------------------------------------------------
function F = bushing_forces(x, model)
% What part 1 exerts on part 2 through each bushing, in the axes of its J marker, (10): cases x 6 x bushings.
%
% The results file holds the force *on* the I marker (its opposite) along the global axes, and the torque about I. The torque at
% J would hold delta x F besides.
rows = find(x.equilibrium);
F = zeros(length(rows), 6, length(model));
for b = 1:length(model)
    e = find(strcmp({x.entity.type}, 'Bushing') & [x.entity.id] == model(b).id);
    if length(e) ~= 1
        error('identify_bushings: the results hold no BUSHING/%d', model(b).id);
    end
    column = x.entity(e).column(1:6);
    for l = 1:length(rows)
        R_J = eye(3);
        if ~isempty(model(b).J.part_name)
            p = find(strcmp({x.entity.type}, 'Part') & [x.entity.id] == model(b).J.part);
            angles = x.data(rows(l), x.entity(p).column(4:6));
            if strcmp(x.units.angle, 'deg')
                angles = angles*pi/180;
            end
            R_J = euler313(angles);
        end
        R_J = R_J*model(b).J.B(1:3, 1:3);
        on_I = x.data(rows(l), column);
        F(l, :, b) = -[on_I(1:3)*R_J, on_I(4:6)*R_J];
    end
end

% -------------------------------------------------------------------------------------------------------------------------------
function K = regression(delta, F, K, set)
% One stiffness from its pairs of deflection and force, (13) to (15). Where they do not go together the stiffness is kept.
covariance = mean(delta.*F) - mean(delta)*mean(F);
var_delta = mean(delta.^2) - mean(delta)^2;
var_F = mean(F.^2) - mean(F)^2;
r = covariance/(sqrt(var_delta)*sqrt(var_F));
if r > set.r_min
    if set.inverse_slope
        K = var_F/covariance;
    else
        K = covariance/var_delta;
    end
end

% -------------------------------------------------------------------------------------------------------------------------------
function K = radial(K, F, set)
% One stiffness for x and y of a round bushing, (16).
w = sum((F - repmat(mean(F), size(F, 1), 1)).^2);
if ~set.weight_by_load
    w = 1./w;
end
K = sum(w.*K)/sum(w)*[1 1];
